"""Cases by which a change of the diagnosis is judged: other fields' simulators, and measurements with a known answer."""
