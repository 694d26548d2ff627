"""What a run leaves behind: result files, pictures, the summary and the closing table."""
