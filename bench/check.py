def run(kind, name):
    return []
