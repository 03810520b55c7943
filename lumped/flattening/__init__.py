"""A model as equations: from the tree of components to one flat list."""
