"""What a user writes: expressions, quantities, ports, components, connections."""
