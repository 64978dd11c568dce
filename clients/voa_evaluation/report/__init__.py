"""Reports of evaluations: CSV files, pictures, and the sections of the HTML page."""
