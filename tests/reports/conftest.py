from benchmark_records import benchmark, make_record

__all__ = ["benchmark", "make_record"]
