"""Migrations of the tables: a numbered file for each revision."""
