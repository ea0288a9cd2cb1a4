"""Data for computations on a page: models, laws and encoders as WebAssembly, parameters with sliders, and rows of a log."""
