"""What surfaces are made of, the ground of R: each material's f, its sampling and the density of that."""
