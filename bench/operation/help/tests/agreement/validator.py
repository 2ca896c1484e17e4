"""Validates JSON by a schema of draft 2020-12: the first line of standard input is the schema, each other one an instance.

Each line is answered by the list of its errors; the errors of the first line are those of the schema itself.
"""

import json
import sys

from jsonschema_rs import Draft202012Validator, ValidationError, meta


def answer(errors):
    print(json.dumps(errors), flush=True)


schema = json.loads(sys.stdin.readline())
try:
    meta.validate(schema)
    answer([])
except ValidationError as error:
    answer([error.message])

validator = Draft202012Validator(schema, validate_formats=True)
for line in sys.stdin:
    errors = validator.iter_errors(json.loads(line))
    answer([f"{'/'.join(map(str, error.instance_path))}: {error.message}" for error in errors])
