"""How a driveline turns: one joint, a chain of them, and the industry's equivalents."""
