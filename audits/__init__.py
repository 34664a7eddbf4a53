"""Audits of programs: see README.md beside this file."""
