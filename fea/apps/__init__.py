"""The job behind `fea run`."""
