"""How results are drawn, and the page that shows them."""
