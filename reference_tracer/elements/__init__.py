"""Parts of the finite elements: meshes and bases, form factors, averages over pixels."""
