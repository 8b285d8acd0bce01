"""Commands, a module each: ``add_arguments(parser)``, ``execute(args) -> int``; `job` is a run."""

#: Summaries of the commands; any other word on the command line is a case to run.
COMMANDS = {
    "init": "writes a commented case to start from; without a name, lists them",
    "check": "validates a case and estimates what it will cost",
    "study": "runs a case with many changes: a table and a plot of error against cost",
    "plot": "draws curves of the history, pictures of frames, fields along a line",
    "report": "writes one page of HTML of a run, also while it goes on, or of a study",
    "export": "makes frames readable for VTK and ParaView, or writes tables (CSV) or VTU",
    "element": "tells what a material does along a path, without a grid",
    "batch": "writes a script for Slurm or PBS that takes a run to its end",
    "compare": "tells whether two runs have the same particles, bit for bit",
    "bench": "measures the speed of this machine by phase",
    "doctor": "checks that MPI, HDF5, h5py and Numba are there and fit each other",
    "schema": "prints the JSON schema of the case file, for editors",
    "completion": "prints what makes bash or zsh complete these words",
}
