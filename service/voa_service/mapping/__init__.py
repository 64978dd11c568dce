"""Messages (`voa_msgs`) to mathematics (`voa_core`), and back."""
