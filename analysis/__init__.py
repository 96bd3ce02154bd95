"""What can be said about a Lur'e loop, by what means, and with which margin."""
