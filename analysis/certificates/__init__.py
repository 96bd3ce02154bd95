"""Certificates: proposed by searches, decided by :mod:`analysis.certificates.checker`."""
