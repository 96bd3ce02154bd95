"""The paper's rod: parameters, transfer function, the upwind scheme, weak form, network, and the exact motion."""
