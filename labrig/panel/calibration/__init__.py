"""The camera's calibration by the operator: views of a board, clicked points, scale and axes."""
