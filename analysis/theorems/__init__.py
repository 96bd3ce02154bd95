"""Criteria for absolute stability, one file each."""
