"""How results are drawn and saved with their captions, and the page that shows them."""
