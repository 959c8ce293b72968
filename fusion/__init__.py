"""Maps and histograms become depths; depths are splatted on the camera's image."""
