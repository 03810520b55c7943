"""What fits at an instant: positions, impacts, reactions and how constraints share them."""
