"""Critical speeds: where orders of excitation meet natural frequencies."""
