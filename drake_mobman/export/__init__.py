"""Laws, written for the tools of others."""
