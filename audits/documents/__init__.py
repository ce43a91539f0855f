"""One module a document: its printed numbers with the computation of each."""
