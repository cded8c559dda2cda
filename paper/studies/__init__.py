"""The paper's single experiments and ablations: cells beside the benchmark."""
