"""The frequency inequality of a plant, decided over the whole axis: polynomials, balls, matrices, samples."""
