"""Certificates: proposed by searches, decided by :mod:`lure.analysis.certificates.checker`."""
