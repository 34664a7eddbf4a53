"""The thesis (Kumar 2015): its figures drawn anew, its claims judged by computation."""
