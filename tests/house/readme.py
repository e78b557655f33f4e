"""Checks that the tables in the benches' READMEs are what their commands print from the kept results. Runs in the source
directory."""
import subprocess
import sys

sys.exit(subprocess.run([sys.executable, "-B", "bench/lib/write_tables.py", "--check"], check=False).returncode)
