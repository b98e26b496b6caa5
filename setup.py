"""What pyproject.toml cannot express: `examples/` is installed as the package
`omnivat_examples`.
"""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["omnivat*", "app*"]), "omnivat_examples"],
    package_dir={"omnivat_examples": "examples"},
)
