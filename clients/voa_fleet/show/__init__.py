"""Pictures, videos, pages and lines in a terminal that show an episode."""
