"""What every renderer needs of a world: surfaces, textures, ground tiles, shadows, appearances."""
