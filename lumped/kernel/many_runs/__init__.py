"""Many runs: one after the other, and side by side in vector registers."""
