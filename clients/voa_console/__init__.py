"""Console: the laboratory's web page, a customer of the service like any other.

| to                    | see           |
|-----------------------|---------------|
"""
