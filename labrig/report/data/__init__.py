"""What a report is made from: measurements, fits, data quality."""
