"""Result files, pictures, tables, statements, terminal output and reports of runs."""
