from lure.expressions.expression import Expression as Expression
