"""Public logs by URL and SHA-256, from a server of this test: no file is ever there in part or another one."""
import functools
import hashlib
import http.server
import os
import subprocess
import sys
import threading

from fricid_program import SOURCE, ProgramTest

FETCH = SOURCE / "scenes/real_logs/fetch.py"


class Server(http.server.SimpleHTTPRequestHandler):
    asked = []

    def do_GET(self):
        self.asked.append(self.path)
        if self.path.endswith("broken.csv"):  # the connection ends after half of it
            self.send_response(200)
            self.send_header("Content-Length", "20")
            self.end_headers()
            self.wfile.write(b"t,q1\n0,0\n")
        else:
            super().do_GET()

    def log_message(self, *_):
        pass


class Fetch(ProgramTest):
    def setUp(self):
        super().setUp()
        self.public, self.logs = self.folder / "public", self.folder / "logs"
        (self.public / "two_2020").mkdir(parents=True)
        server = http.server.ThreadingHTTPServer(
            ("127.0.0.1", 0), functools.partial(Server, directory=self.public))
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.url = f"http://127.0.0.1:{server.server_port}"
        self.lines = []
        Server.asked.clear()

    def publish(self, scene, name, content=b"t,q1\n0,0\n0.01,0.1\n", url=None, there=True):
        if there:
            (self.public / name).parent.mkdir(exist_ok=True)
            (self.public / name).write_bytes(content)
        url = url or f"{self.url}/{name}"
        self.lines.append(f"{hashlib.sha256(content).hexdigest()} {scene} {name} {url}")

    def fetch(self, *scenes, environment={}):
        table = self.write("files.txt", "# a table\n" + "\n".join(self.lines) + "\n")
        return subprocess.run([sys.executable, FETCH, self.logs, *scenes, "--table", table], capture_output=True,
                              text=True, env=os.environ | environment)

    def files(self):
        return sorted(str(path.relative_to(self.logs)) for path in self.logs.rglob("*") if path.is_file())

    def test_what_is_there_is_not_fetched_again(self):
        self.publish("one", "one_2019/a.csv")
        self.publish("two", "two_2020/b.csv", b"other")
        done = self.fetch()
        self.assertEqual((done.returncode, done.stdout), (0, "one,two\n"), done.stderr)
        self.assertEqual(self.files(), ["one_2019/a.csv", "two_2020/b.csv"])
        self.assertEqual((self.logs / "two_2020/b.csv").read_bytes(), b"other")
        (self.logs / "one_2019/a.csv").unlink()
        Server.asked.clear()
        self.assertEqual(self.fetch().returncode, 0)
        self.assertEqual(Server.asked, ["/one_2019/a.csv"])
        self.assertEqual(self.fetch("two").stdout, "two\n")

    def test_a_mirror_has_all_files(self):
        self.publish("one", "one_2019/a.csv", url="http://127.0.0.1:1/nobody")
        self.publish("two", "two_2020/b.csv", b"x", url="- converted from b.mat")
        done = self.fetch(environment={"FRICID_REALLOGS_URL": self.url + "/"})
        self.assertEqual((done.returncode, done.stdout), (0, "one,two\n"), done.stderr)

    def test_what_cannot_be_had_is_one_line_and_no_file(self):
        for name, url, why in (("one/a.csv", "http://127.0.0.1:1/a.csv", "refused"),
                               ("one/a.csv", f"{self.url}/absent.csv", "404"),
                               ("one/a.csv", f"{self.url}/broken.csv", "20|IncompleteRead"),
                               ("one/a.csv", "nonsense", "unknown url")):
            self.lines.clear()
            self.publish("one", name, url=url)
            self.assert_refused(self.fetch(), rf"logs/one/a\.csv: cannot be had from {url}: .*({why})")
            self.assertEqual(self.files(), [])

    def test_another_file_is_refused_and_left(self):
        self.publish("one", "one/a.csv")
        (self.public / "one/a.csv").write_bytes(b"changed")
        self.assert_refused(self.fetch(), rf"logs/one/a\.csv: SHA-256 of {self.url}/one/a\.csv is [0-9a-f]+, not ")
        self.assertEqual(self.files(), [])
        (self.logs / "one/a.csv").write_bytes(b"mine")
        self.assert_refused(self.fetch(), rf"logs/one/a\.csv: SHA-256 is .*{self.url}/one/a\.csv")
        self.assertEqual((self.logs / "one/a.csv").read_bytes(), b"mine")

    def test_what_is_published_in_another_form_is_put_there_by_hand(self):
        self.publish("one", "one/a.csv")
        self.publish("two", "two/b.csv", b"x", url="- converted from b.mat", there=False)
        done = self.fetch()
        self.assertEqual((done.returncode, done.stdout), (0, "one\n"))
        self.assertRegex(done.stderr, r"two is left out: .*two/b\.csv is not there, put it there: converted from b\.mat")
        self.assert_refused(self.fetch("two"), r"two/b\.csv is not there, put it there: converted from b\.mat")
        (self.logs / "two").mkdir()
        (self.logs / "two/b.csv").write_bytes(b"y")
        self.assert_refused(self.fetch("two"), r"two/b\.csv: SHA-256 is .*converted from b\.mat")
        (self.logs / "two/b.csv").write_bytes(b"x")
        self.assertEqual(self.fetch().stdout, "one,two\n")

    def test_a_scene_without_a_log_is_named(self):
        self.publish("one", "one/a.csv")
        self.assert_refused(self.fetch("three"), "three: no public log; there are one")

    def test_the_table_names_files_of_its_scenes(self):
        table = [line.split() for line in (SOURCE / "scenes/real_logs/files.txt").read_text().splitlines() if line[0] != "#"]
        for scene in {fields[1] for fields in table}:
            text = (SOURCE / f"scenes/{scene}.toml").read_text()
            for name in (fields[2] for fields in table if fields[1] == scene):
                self.assertIn(f"$FRICID_REALLOGS/{name}", text)


if __name__ == "__main__":
    import unittest
    unittest.main()
