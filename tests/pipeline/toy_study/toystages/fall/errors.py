class NoFall(ValueError):
    pass
