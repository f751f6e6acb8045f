"""Compares this package with others: ``python -m rher.compare``.

Everything is measured anew, side by side in one run, and written to a folder: ``compare.md`` has the
tables, ``compare.json`` the raw data. ``pip install 'rher[compare]'`` installs what is compared.
Nothing else imports this package. What it compares is a list of parts, in ``command.py``.
"""
