"""The oil film between a pin and its bore: Reynolds' equation with cavitation, on a rigid or elastic bore."""
