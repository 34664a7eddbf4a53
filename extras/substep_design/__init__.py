"""Design: from requirements to exact parameters of a declared scheme, or to a composite scheme that meets them."""
