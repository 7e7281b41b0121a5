"""Search the candidates: their evidence, ranking, refinement and cross-validation."""
