"""The device on which the networks of a method are."""


def require_device(device: str) -> None:
    """Raise ValueError unless PyTorch finds the device, "cpu" or "cuda", on this machine."""
    if device == "cuda":
        import torch

        if not torch.cuda.is_available():
            raise ValueError("PyTorch finds no CUDA device on this machine; leave device at cpu")
