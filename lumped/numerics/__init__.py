"""Methods independent of models: steps, eigenvalues, closed forms, programmes, processes."""
