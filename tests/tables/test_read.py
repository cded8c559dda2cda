"""Files as they are published, small and written by hand; histograms of the libraries that people use."""

import boost_histogram as bh
import numpy as np
import pytest
import uproot

import avobench
from avobench.tasks.errors import UsageError

HEPDATA_CSV = """\
#: name: Table 1
#: description: Sphericity distribution.
#: data_file: Table1.yaml
#: keyword reactions: E+ E- --> Z0 --> HADRONS
#: keyword observables: DSIG/DS
#: table_doi: 10.17182/hepdata.47582.v1/t1
#: RE,,E+ E- --> HADRONS
#: SQRT(S) [GeV],,91.2
S,S LOW,S HIGH,1/SIG*D(SIG)/DS,stat +,stat -,"sys,1 +","sys,1 -"
0.005,0.0,0.01,12.36,0.3,-0.3,0.4,-0.4
0.02,0.01,0.03,23.33,0.3,-0.1,0.2333,

#: name: Table 2
S,S LOW,S HIGH,N
0.5,0.0,1.0,7
1.5,1.0,2.0,9

S,S LOW,S HIGH,M
0.5,0.0,1.0,3
1.5,1.0,2.0,4
"""
HEPDATA_YAML = """\
dependent_variables:
- header: {name: 1/SIG*D(SIG)/DS, units: ''}
  qualifiers:
  - {name: SQRT(S), units: GeV, value: 91.2}
  values:
  - errors:
    - {label: stat, symerror: 0.3}
    - {label: sys, symerror: 0.4}
    value: 12.36
  - errors:
    - asymerror: {minus: -0.1, plus: 0.3}
      label: stat
    - {label: sys, symerror: 1%}
    value: 23.33
- header: {name: N}
  values:
  - {value: 7}
  - {value: 9}
independent_variables:
- header: {name: S, units: GeV}
  values:
  - {high: 0.01, low: 0.0}
  - {high: 0.03, low: 0.01}
"""
PLAIN = "table,low,high,value,error\na,0,1,5,0.5\na,1,3,6,0.6\nb,0,1,7,0.7\n"


@pytest.fixture
def written(tmp_path):
    """A file of this text, by its name."""

    def write(name, text):
        (path := tmp_path / name).write_text(text, newline="")
        return path

    return write


def errors(table):
    return np.sqrt(np.diag(table.covariance))


def test_tables_of_hepdata_are_the_same_from_csv_and_yaml(written):
    names = {written("a.csv", HEPDATA_CSV): "Table 1", written("a.yaml", HEPDATA_YAML): "1/SIG*D(SIG)/DS"}
    csv, yaml = (avobench.read_table(path, name, density=True) for path, name in names.items())
    assert (yaml.unit, csv.density, csv.name) == ("GeV", True, "Table 1")
    for table in (csv, yaml):
        assert table.edges.tolist() == [0, 0.01, 0.03]
        assert table.values.tolist() == [12.36, 23.33]
        assert errors(table) == pytest.approx([0.5, np.hypot(np.sqrt(0.05), 0.2333)])
    for counts in (avobench.read_table(path, "N") for path in names):
        assert counts.values.tolist() == [7, 9]
        assert counts.are_counts


def test_a_plain_text_holds_several_tables(written):
    table = avobench.read_table(written("a.csv", PLAIN), "a", normalised=True, name="mine")
    assert (table.edges.tolist(), table.values.tolist(), table.name) == ([0, 1, 3], [5, 6], "mine")
    assert errors(table) == pytest.approx([0.5, 0.6])
    joint = avobench.read_table(written("a.csv", PLAIN), "a", normalised=True, covariance=[[1, 0.5], [0.5, 1]])
    assert joint.covariance[0, 1] == 0.5


@pytest.mark.parametrize("weights", [None, [0.5, 2.0, 1.0, 1.0]])
def test_histograms_are_read_from_memory_and_from_root(weights, tmp_path):
    made = bh.Histogram(bh.axis.Variable([0, 1, 2, 4]), storage=bh.storage.Weight())
    made.fill([0.5, 1.5, 3, 3.5], weight=weights or 1.0)
    with uproot.recreate(tmp_path / "a.root") as file:
        file["counts"] = made
    for source in (made, f"{tmp_path / 'a.root'}:counts"):
        table = avobench.read_table(source)
        assert table.edges.tolist() == [0, 1, 2, 4]
        assert table.values.tolist() == ([1, 1, 2] if weights is None else [0.5, 2, 2])
        if weights is None:
            assert table.are_counts
        else:
            assert errors(table) == pytest.approx([0.5, 2, np.sqrt(2)])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "low,high,value\n0,1,1200\n1,2,700\n2,inf,1100\n"),
        ("a.yaml", HEPDATA_YAML.replace("high: 0.03", "high: .inf")),
    ],
)
def test_an_open_last_bin_is_read(name, text, written):
    table = avobench.read_table(written(name, text), "N" if name == "a.yaml" else None)
    assert table.edges[-1] == np.inf
    assert np.isfinite(table.edges[:-1]).all()


def test_names_of_columns_are_known_with_capitals(written):
    told = PLAIN.replace("table,low,high,value,error", "Table,Low,High,Value,Error")
    assert errors(avobench.read_table(written("a.csv", told), "b", normalised=True)) == pytest.approx([0.7])


def test_an_axis_of_whole_numbers_has_a_bin_around_each():
    x = np.random.default_rng(0).poisson(3, 200)
    table = avobench.read_table(bh.Histogram(bh.axis.Integer(0, 6)).fill(x))
    assert table.entries(x).sum(axis=0).tolist() == table.values.tolist() == np.bincount(x)[:6].tolist()


@pytest.mark.parametrize(
    ("name", "text", "table", "word"),
    [
        ("a.csv", PLAIN, None, "several tables; choose one of: a, b"),
        ("a.csv", PLAIN, "c", "no table 'c'; choose one of: a, b"),
        ("a.csv", "low,high,value\n0,1,2\n1.5,2,3\n", None, "bin 1 ends at 1, but bin 2 begins at 1.5"),
        ("a.csv", "low,value\n0,1\n", None, "no column 'high'; it has: low, value"),
        ("a.csv", "low,high\n0,1\n", None, "no column of values"),
        ("a.csv", "low,high,value\n0,1\n", None, "line 2 has 2 cells and the columns are 3"),
        ("a.csv", "low,high,value\n0,1,-\n", None, "line 2 has '-' in place of a number"),
        ("a.csv", "low,high,value,error\n0,1,2,\n", None, "must be positive"),
        ("a.csv", "low,high,value,stat,syst\n0,1,2,1,1\n", None, "stat, syst"),
        ("a.csv", "low,high,value,stat +\n0,1,2,1\n", None, "stat"),
        ("a.csv", "low,high,value,error\n0,1,2,-1\n", None, "line 2 has an error of -1"),
        ("a.csv", "low,high,value,error,sys +,sys -\n0,1,2,1,1,-1\n", None, "'error' beside sys"),
        ("a.csv", "low,high,value,a +,b -\n0,1,2,1,1\n", None, "two sides"),
        ("a.csv", "low;high;value\n0,5;1,5;12\n1.5;3;5\n", None, "write all of them in one way"),
        ("a.csv", "", None, "holds no table"),
        ("a.dat", "", None, "tables are read from"),
        ("a.yaml", "a: [", None, "no YAML"),
        ("a.yaml", HEPDATA_YAML.replace("{high: 0.01, low: 0.0}", "{value: 1}"), None, "points in place of bins"),
        ("a.yaml", HEPDATA_YAML.replace("  - {value: 9}\n", ""), "N", "1 values for 2 bins"),
        ("a.yaml", HEPDATA_YAML.replace("{value: 9}", 'value: "-"'), "N", "'-' in place of a number"),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(name, text, table, word, written):
    with pytest.raises(UsageError, match=word) as raised:
        avobench.read_table(written(name, text), table)
    assert "\n" not in str(raised.value)


def test_what_is_no_histogram_of_counts_is_told_in_one_line(tmp_path):
    two = bh.Histogram(bh.axis.Regular(2, 0, 1), bh.axis.Regular(2, 0, 1))
    profile = bh.Histogram(bh.axis.Regular(2, 0, 1), storage=bh.storage.Mean())
    names = bh.Histogram(bh.axis.StrCategory(["a", "b"]))
    with uproot.recreate(tmp_path / "a.root") as file:
        file["h"] = bh.Histogram(bh.axis.Regular(2, 0, 1))
    of_memory = (two, "one axis"), (profile, "mean in each bin"), (names, "names"), (3, "got int")
    of_file = (f"{tmp_path}/a.root:g", "no TH1 'g'; it has: h"), (f"{tmp_path}/a.root", "no TH1 ''; it has: h")
    for source, word in (*of_memory, *of_file, ("nowhere.csv", "no file")):
        with pytest.raises(UsageError, match=word):
            avobench.read_table(source)


@pytest.mark.parametrize(
    ("separator", "decimal"), [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ",")], ids=repr
)
def test_cells_are_separated_as_the_line_of_names_says(written, separator, decimal):
    rows = [["of x low", "high", "value", "error"], ["0.5", "1.5", "12.25", "1.5e-1"], ["1.5", "3", "5", "10%"]]
    text = "\r\n".join(separator.join(cell.replace(".", decimal) for cell in row) for row in rows)
    table = avobench.read_table(written("table.csv", "# published\r\n" + text), normalised=True)
    assert table.edges.tolist() == [0.5, 1.5, 3]
    assert table.values.tolist() == [12.25, 5]
    np.testing.assert_allclose(errors(table), [0.15, 0.5])
