"""What comes back from a pickle."""

import pickle



def same(a, b):
    """Whether two results are equal, numbers that are none too."""
    import numpy as np
    import wingbeat
    from wingbeat import learn

    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray | np.generic):
        kind = a.dtype.kind
        return kind == b.dtype.kind and (kind not in "biuf" or np.array_equal(a, b, equal_nan=kind == "f"))
    if isinstance(a, wingbeat.Record):
        return a.columns == b.columns and all(same(a[name], b[name]) for name in a)
    if isinstance(a, wingbeat.Strips):
        return same(a.record, b.record)
    if isinstance(a, wingbeat.Stepper):
        return a.t == b.t and same(a.state, b.state) and same(a.inputs, b.inputs)
    if isinstance(a, wingbeat.Measurement):
        return a.taken == b.taken and a.names == b.names and same(a.array, b.array)
    if isinstance(a, learn.Environment | learn.VectorEnvironment):
        return same(a._flock.native.save(), b._flock.native.save())
    if isinstance(a, float):
        return a == b or (a != a and b != b)
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if hasattr(a, "__dataclass_fields__"):
        return all(same(getattr(a, key), getattr(b, key)) for key in a.__dataclass_fields__)
    if isinstance(a, wingbeat.ResultWarning):
        return a.id == b.id and str(a) == str(b)
    return type(a).__module__.split(".")[0] != "wingbeat" or type(a) is type or a == b or not hasattr(a, "toml")


def ours(value):
    """Whether a value is of the package."""
    of = value[0] if isinstance(value, list) and value else value
    return type(of).__module__.split(".")[0] == "wingbeat"


def kept(thing, words, account):
    """Pickles a thing of the package, and says what is wrong with what comes back."""
    if not ours(thing):
        return None
    kind = type(thing).__name__
    try:
        again = pickle.loads(pickle.dumps(thing))
    except Exception as error:  # noqa: BLE001
        # A plain container of whatever it is given is as good as that.
        plain = hasattr(thing, "__dataclass_fields__") and words.startswith(kind)
        return None if plain else f"{kind} cannot be pickled: {type(error).__name__}: {error}"
    account.counts["pickled"] += 1
    return None if same(thing, again) else f"{kind} is not what it was once it is pickled"
