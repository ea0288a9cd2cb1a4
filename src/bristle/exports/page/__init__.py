"""What a page computes with: models, laws and encoders as WebAssembly, their parameters with sliders, and rows to be led along."""
