"""Pictures and animations, drawn off-screen."""
