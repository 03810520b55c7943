"""Methods that know no model: steps, eigenvalues, closed forms, programmes, processes."""
