"""What a run's assumptions change, and what would make its rod pass: each solved again."""
