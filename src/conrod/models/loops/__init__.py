"""The closed loops of a model whose joints are driven by laws."""
