"""Formulas for laws and signals from files: parsed by a whitelist, never evaluated by Python or sympy."""

from lure.expressions.expression import Expression as Expression
