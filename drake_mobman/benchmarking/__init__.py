"""What blocks and whole runs cost."""
