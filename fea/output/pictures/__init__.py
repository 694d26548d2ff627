"""Pictures, animations and their page, drawn off-screen."""
