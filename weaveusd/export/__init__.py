"""Export: images, the USD asset, MaterialX, and the atomic publish."""
